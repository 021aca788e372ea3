"""Which effects a recording supports: the catalogue screened, fitted, and compared."""
