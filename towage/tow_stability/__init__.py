"""Stability of towed bodies over speed."""
