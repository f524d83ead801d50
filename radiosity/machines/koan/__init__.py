"""KOAN's machine (Badouel et al. 1991): a virtual memory that nodes with memories of their own share by pages."""
