"""Images by a third party, and how to make them again."""
