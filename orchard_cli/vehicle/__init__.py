"""The MAVSDK link and the watchdog."""
