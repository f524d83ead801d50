"""The results of sections, into main memory."""
