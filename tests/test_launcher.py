"""crossfield.py before any environment is there: versions, help, what each command needs."""

import subprocess
import sys
from pathlib import Path

import crossfield


def test_other_versions_of_python_get_one_sentence(monkeypatch, capsys):
    monkeypatch.setattr(sys, "version_info", (3, 12, 1, "final", 0))
    assert crossfield.main(["example"]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1
    assert "3.11 or 3.13" in err and "3.12" in err


def test_help_needs_nothing():
    command = [sys.executable, "-S", "-E", crossfield.__file__, "--help"]
    outcome = subprocess.run(command, capture_output=True, text=True)
    assert outcome.returncode == 0 and outcome.stderr == ""
    for word in ("example", "test", "decompose"):
        assert f"crossfield.py {word}" in outcome.stdout


def test_blender_is_needed_for_its_files_and_pictures_only():
    assert crossfield.modules_for(["decompose", "a.obj", "--quads", "b.obj"]) == ("numpy",)
    assert "bpy" in crossfield.modules_for(["decompose", "a.BLEND"])
    assert "bpy" in crossfield.modules_for(["decompose", "a.obj", "--output=b.blend"])
    assert "bpy" in crossfield.modules_for(["decompose", "a.obj", "--picture", "b.png"])


def test_requirements_are_those_of_the_project():
    assert [r[:5] for r in crossfield.requirements(("numpy",))] == ["numpy"]
    wanted = " ".join(crossfield.requirements(crossfield.NEEDED["test"]))
    assert all(name in wanted for name in ("numpy", "bpy==4.5", "bpy==5.2", "pytest", "scipy"))


def test_an_environment_that_cannot_be_made_is_one_sentence(tmp_path, monkeypatch, capsys):
    (tmp_path / ".venv-{}.{}".format(*sys.version_info[:2])).write_text("in the way")
    monkeypatch.setattr(crossfield, "ROOT", str(tmp_path))
    monkeypatch.setattr(crossfield, "missing", lambda module: True)
    assert crossfield.main(["decompose", "a.obj"]) == 1
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and "environment" in err
    assert [p.name[:5] for p in Path(tmp_path).iterdir()] == [".venv"]
