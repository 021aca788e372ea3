"""Diagnosis: detect → locate → screen → fit → decide → report, one module per step."""
