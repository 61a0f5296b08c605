"""Response of tows over frequency."""
