"""Towed slender body, flexible or rigid, and the craft before it (McGill thesis)."""
