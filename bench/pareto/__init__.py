"""What accuracy costs: error against processor time; see ``bench/README.md``."""
