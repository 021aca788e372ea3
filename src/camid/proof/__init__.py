"""The sealed proof: recordings with a concealed effect are made, sealed, diagnosed blindly, revealed and scored."""
