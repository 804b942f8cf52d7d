"""The compiler: one `.sj` text becomes one readable Python module, stage by stage."""
