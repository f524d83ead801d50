"""Jobs: a queue of loads and sections of frusta, and the results that each section leaves in main memory."""
