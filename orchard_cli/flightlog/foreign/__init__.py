"""Logs of other programs -> FlownLog: ROS 2 bags (MCAP) and PX4 ULog."""
