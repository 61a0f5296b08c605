"""Runs in processes of their own, supervised; progress; files that survive."""
