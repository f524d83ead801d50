"""Worker processes, on this machine or others, that compute spans of work."""
