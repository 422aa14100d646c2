"""What PERIDEM costs, measured side by side on the machine it runs on; see ``bench/README.md``."""
