"""Control between the units: loads, casts, results, and errors."""
