"""What joins the units: loading, casting, writing, and what goes wrong."""
