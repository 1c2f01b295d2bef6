"""How does a valve follow its set point? Controllers, closed loops on the exact valve, measures, contests."""
