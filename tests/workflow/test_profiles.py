"""Profiles say only what Snakemake, or the plugin that one of them names, understands. No Slurm needed."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML
from snakemake.cli import get_argument_parser
from snakemake.profiles import ProfileConfigFileParser

from tests.support import ROOT

PROFILES = sorted((ROOT / "workflow/profiles").glob("*/config.yaml"))
SLURM = ROOT / "workflow/profiles/slurm/config.yaml"
# Source: the fields of ExecutorSettings in snakemake-executor-plugin-slurm 2.8.0;
# `snakemake --help` shows each with `--slurm-` in front.
SLURM_SETTINGS = {
    *("array_jobs", "array_limit", "delete_logfiles_older_than", "disable_memory_fudge", "efficiency_report"),
    *("efficiency_report_path", "efficiency_threshold", "exclude_failed_nodes", "init_seconds_before_status_checks"),
    *("jobname_prefix", "keep_successful_logs", "logdir", "no_account", "no_requeue", "partition_config"),
    *("pass_command_as_script", "qos", "requeue", "reservation", "status_attempts", "status_command"),
}
SLURM_OPTIONS = {f"slurm-{name.replace('_', '-')}" for name in SLURM_SETTINGS}
# What the plugin or Snakemake itself makes of a resource; a misspelt one would be taken for one of the user's own.
RESOURCES = {"mem_mb", "mem_mb_per_cpu", "disk_mb", "runtime", "cpus_per_task", "slurm_account", "slurm_partition"}


def read(profile: Path) -> dict[str, Any]:
    """The profile; a key that is written twice is an error."""
    return YAML(typ="safe").load(profile.read_text(encoding="utf-8"))


def numbers(value: Any) -> Iterator[float]:
    """All numbers in a profile, at any depth; switches are none."""
    if isinstance(value, dict):
        for below in value.values():
            yield from numbers(below)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield value


def not_understood(profile: Path) -> set[str]:
    """Keys that neither Snakemake nor the Slurm plugin would take."""
    options = {
        key for action in get_argument_parser()._actions for key in (o.lstrip("-") for o in action.option_strings)
    }
    return set(read(profile)) - options - SLURM_OPTIONS


@pytest.mark.parametrize("profile", PROFILES, ids=lambda p: p.parent.name)
def test_every_key_is_an_option(profile):
    assert not_understood(profile) == set()


@pytest.mark.parametrize("profile", PROFILES, ids=lambda p: p.parent.name)
def test_snakemake_accepts_every_value(profile):
    """Through Snakemake's own reader of profiles and its own command line."""
    parser = get_argument_parser()
    actions = {key: action for action in parser._actions for key in parser.get_possible_config_keys(action)}
    with profile.open(encoding="utf-8") as stream:
        items = ProfileConfigFileParser().parse(stream)
    assert set(items) == set(read(profile))  # the reader passes over mappings that it does not expect
    # Without the plugin, neither its options nor its name are known.
    own = {
        key: value for key, value in items.items() if key not in SLURM_OPTIONS and (key, value) != ("executor", "slurm")
    }
    arguments = [
        a for key, value in own.items() for a in parser.convert_item_to_command_line_arg(actions[key], key, value)
    ]
    parser.parse_args(arguments)


@pytest.mark.parametrize("profile", PROFILES, ids=lambda p: p.parent.name)
def test_numbers_and_resources_make_sense(profile):
    settings = read(profile)
    assert all(number > 0 for number in numbers(settings))
    assert set(settings.get("default-resources", {})) <= RESOURCES


def test_slurm_profile_asks_for_what_a_cluster_needs_to_know():
    settings = read(SLURM)
    assert settings["executor"] == "slurm"
    assert {"mem_mb", "runtime", "cpus_per_task"} <= set(settings["default-resources"])
    # The plugin's other choice waits for ever on a cluster without accounting.
    assert settings["slurm-status-command"] == "squeue"
    # One of the two computes a killed job again, never both.
    assert settings["retries"] >= 1
    assert settings["slurm-no-requeue"] is True


def test_slurm_profile_keeps_the_settings_of_the_default_one():
    """`--workflow-profile slurm` leaves the default profile out."""
    assert read(ROOT / "workflow/profiles/default/config.yaml").items() <= read(SLURM).items()


def test_misspelt_key_is_found(tmp_path):
    profile = tmp_path / "config.yaml"
    profile.write_text(
        SLURM.read_text(encoding="utf-8").replace("slurm-status-command", "slurm-status"), encoding="utf-8"
    )
    assert not_understood(profile) == {"slurm-status"}
