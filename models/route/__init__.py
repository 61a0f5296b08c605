"""The minimal-time route of a ship through a changing sea (Naval Postgraduate School, 1964)."""
