"""How exact the engine and weaker methods are, for the time that they take."""
