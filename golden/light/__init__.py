"""Light: form factors, radiosity, and the light at the points that pixels and sensors see."""
