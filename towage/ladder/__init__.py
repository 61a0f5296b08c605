"""The ladder of models of a scene, from the simplest to the fullest: which is enough, at what cost."""
