"""Run time against error: this package and its peers on the same physics, in the same run."""
