"""A small correct engine, and others made from it that are wrong on purpose, each in one small way.

`textbook` is right: plain floats and the formulas of any textbook, written without a look at `refimpl`. The others
override one step of it in one cell. They show what the hunter finds: ``proxyproof hunt-mutants``.
"""
