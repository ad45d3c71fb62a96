"""One step in time: tableaux, Newton, methods, the energy ledger."""
