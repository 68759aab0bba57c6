"""The pictures that the command draws."""
