"""Light: form factors, radiosity, and the picture."""
