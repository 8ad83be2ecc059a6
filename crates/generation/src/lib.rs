//! Floor 6: text to motion that a robot can execute (thesis chapter 5, RobotMDM).
