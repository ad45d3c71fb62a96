"""What an arm looks like: outlines, tubes, shapes and their colours; no ROS."""
