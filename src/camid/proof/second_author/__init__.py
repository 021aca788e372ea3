"""A second, independent generator of recordings with concealed physics; it imports nothing of camid."""
