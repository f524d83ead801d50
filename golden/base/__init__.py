"""What everything else may use: errors, output, progress, how work is spread, and compiled functions."""
