"""Light as the eye weighs it: lux and candela per square metre."""
