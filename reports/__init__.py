"""Everything that a person types or reads: the command line, the live display, and the written report.

`tables` and `findings` turn a run into rows and sentences, once; `terminal`, `html` and `markdown` only give them
their form; `summary` writes the same as plain data, and `verify` checks a written report for completeness.
"""
