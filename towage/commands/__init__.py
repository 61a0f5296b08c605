"""The commands of the command line, one module each; see `towage.cli`."""
