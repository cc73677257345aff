"""The nouns that cross rooms; numpy only. Import from the file that names the noun."""
