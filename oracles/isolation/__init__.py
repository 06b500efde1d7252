"""Processes between an engine and the harness, so that nothing an engine does to its own process reaches ours.

    worker (our process) ── guard ── fork server ── hand
                                     imports the    asks the engine,
                                     engine         and may be lost

The *guard* runs no line of the engine's code: it watches clock, memory and processes. The *fork server* imports the
engine once and makes *hands*, each in a few milliseconds. The hand makes the calls and writes each answer to the
*board*, memory that all share, so that what was answered stays answered whoever is killed.
"""
