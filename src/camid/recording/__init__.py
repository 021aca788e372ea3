"""Recordings: tables from files of many kinds, their columns, units and time grid."""
