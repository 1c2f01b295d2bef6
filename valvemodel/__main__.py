"""`python -m valvemodel`: the command line."""

from valvemodel.commands import main

main()
