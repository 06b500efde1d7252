"""How fast the reference is beside the engines: ``python -m tests.benchmarks``, and pytest-benchmark on demand.

``pytest tests/benchmarks/bench_pairs.py -n 0`` times single cells; the name keeps it out of the ordinary tests.
"""
