"""What the workflow computes: datasets, identification runs and the claims drawn from them. No drawing here."""
