"""Makes px4_pi_20x6.ulg.xz: the topics that analysis reads, every tenth sample, of a PX4 flight.

python tests/data/extract_ulog.py flight_pi_20x6.ulg tests/data/px4_pi_20x6.ulg.xz
"""

import lzma
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from pyulog import ULog

TOPICS = ["vehicle_local_position", "vehicle_attitude", "trajectory_setpoint", "battery_status"]
STEP = {"vehicle_local_position": 10, "vehicle_attitude": 20}


def main() -> None:
    log = ULog(sys.argv[1], TOPICS)
    for one in log.data_list:
        step = STEP.get(one.name, 1)
        for name in one.data:
            one.data[name] = one.data[name][::step]
    log._initial_parameters.clear()
    log._changed_parameters.clear()
    log._msg_info_multiple_dict.clear()
    with TemporaryDirectory() as folder:
        small = Path(folder) / "small.ulg"
        log.write_ulog(str(small))
        Path(sys.argv[2]).write_bytes(lzma.compress(small.read_bytes(), preset=9))


if __name__ == "__main__":
    main()
