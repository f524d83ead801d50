"""Light: form factors, radiosity, and the image."""
