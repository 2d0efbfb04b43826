"""Read what a vehicle said of its battery, in whichever message: voltage and charge over time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.table import Table
from flightstack.logs.flight.vehicle import LoggedVehicle

UNKNOWN_MV = 65535
MIN_CHARGE = 0  # %; below it is not known
CHARGE_FIELDS = {
    "SYS_STATUS": "battery_remaining",
    "BATTERY_STATUS": "battery_remaining",
    "HIGH_LATENCY2": "battery",
    "HIGH_LATENCY": "battery_remaining",
}

Floats = NDArray[np.float64]
Times = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Battery:
    """Voltage and charge, each at its own times; empty where not told."""

    voltage_at_us: Times
    volts: Floats
    charge_at_us: Times
    percent: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.volts) + len(self.percent)


def _first_battery(table: Table) -> Table:
    return table.take(table["id"] == table["id"].min()) if len(table) else table


def _cell_volts(table: Table) -> Floats:
    """Return the sum of all cells that are told, NaN where none is."""
    cells = np.hstack([table["voltages"].astype(np.float64), table["voltages_ext"]])
    told = (cells > 0) & (cells != UNKNOWN_MV)
    return np.where(told.any(axis=1), np.where(told, cells, 0).sum(axis=1) * 1e-3, np.nan)


def _voltage(status: Table, battery: Table) -> tuple[Times, Floats]:
    volts = status["voltage_battery"] * 1e-3
    told = (volts > 0) & (status["voltage_battery"] != UNKNOWN_MV)
    if told.any():
        return status.time_us[told], np.asarray(volts[told], dtype=np.float64)
    volts = _cell_volts(battery)
    told = np.isfinite(volts)
    return battery.time_us[told], volts[told]


def find_battery(log: Log, vehicle: LoggedVehicle) -> Battery:
    """Return what is told: each by the first of CHARGE_FIELDS' messages that knows it."""
    tables = {name: vehicle.sent(log, name) for name in CHARGE_FIELDS}
    tables["BATTERY_STATUS"] = _first_battery(tables["BATTERY_STATUS"])
    voltage_at_us, volts = _voltage(tables["SYS_STATUS"], tables["BATTERY_STATUS"])
    charge_at_us, percent = voltage_at_us[:0], np.empty(0, dtype=np.int64)
    for name, field in CHARGE_FIELDS.items():
        charge = tables[name][field].astype(np.int64)
        told = (charge >= MIN_CHARGE) & (charge <= 100)
        if told.any():
            charge_at_us, percent = tables[name].time_us[told], charge[told]
            break
    return Battery(
        voltage_at_us=voltage_at_us, volts=volts, charge_at_us=charge_at_us, percent=percent
    )
