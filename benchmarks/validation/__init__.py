"""Others judge this package: ``python -m benchmarks.validation``, see docs/validation.md."""
