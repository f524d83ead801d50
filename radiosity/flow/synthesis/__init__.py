"""Area and clock of a component from open tools."""
