"""How well the tests test: the mutants of the C code that they kill, the branches that they take."""
