"""Studies of motion and impacts: small experiments with a plot and a table each, made again by one command."""
