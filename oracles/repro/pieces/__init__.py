"""The pieces of which repro scripts are made: a second exact checker, plain enough to be read by a stranger.

Standard library only, and nothing of this project: `oracles.repro.selecting` copies into each script the functions
and methods that its own certificate needs. It shares no line with `refimpl.proof`, against which it is tested: sets
are written down directly, for one kind of shape each, without the limits on effort that certificates from strangers
call for.
"""
