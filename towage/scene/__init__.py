"""From text to a scene in which everything exists: reading, resolving, choosing flavours, composing."""
