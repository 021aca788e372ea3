"""The paper: datasets, a folder for each figure (runs and drawing), the quoted numbers and the claims."""
