"""The tables and figures of the four source reports, computed again beside what is printed."""
