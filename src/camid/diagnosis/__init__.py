"""Diagnosis: detect → locate → screen → fit → decide → report, a module a step."""
