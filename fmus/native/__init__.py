"""The native flavour: the model traced to C, compiled with a runtime."""
