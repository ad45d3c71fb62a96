"""Every judge in the tables has its source, its own accuracy, our error, and the command."""


def test_every_row_names_source_accuracy_error_and_command(module):
    pages = module("pages")
    kept = module("__main__").kept()
    rows = pages.overview({name: part["found"] for name, part in kept.items()})
    assert len(rows) > 10
    for row in rows:
        assert len(row) == 6 and all(row[:5]), row
    judges = " ".join(row[0] for row in rows)
    for judge in ("SoRoSim", "ANSYS", "Exudyn", "Kynema", "Simo, Vu-Quoc", "cosseratbench"):
        assert judge in judges


def test_the_pages_show_what_was_found(module):
    pages = module("pages")
    kept = module("__main__").kept()
    root = pages.ROOT
    assert pages.text(kept) in (root / "docs" / "validation.md").read_text()
    assert pages.short_text(kept) in (root / "README.md").read_text()


def test_the_command_names_no_directory_of_its_own_for_the_bank(module):
    main = module("__main__")
    assert not {"sorosim_statics", "sorosim_releases"} & set(main.jobs(None))
