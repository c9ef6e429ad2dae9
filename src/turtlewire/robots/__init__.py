"""The drivers: sessions over a link, exact pose, one file per robot."""
