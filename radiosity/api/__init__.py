"""Functions of the public interface, over what the packages have."""
