"""Numbers of the hand's published property protocol, for both ends of the wire: nodes, groups, properties, modes."""

F1, F2, F3, SPREAD = PUCKS = (11, 12, 13, 14)
FINGERS = PUCKS[:3]
NAMES = {F1: "F1", F2: "F2", F3: "F3", SPREAD: "spread"}
GROUP = 0x400
ALL, HAND = 0, 5  # groups
POSITIONS, VALUES, JOINTS, TOP_TEN, FULL = 3, 6, 7, 8, 9  # groups of answers

VERS, ROLE, SN, ID, ERROR, STAT, MODE, TEMP, OTEMP, THERM, VBUS, IMOTOR, SG = 0, 1, 2, 3, 4, 5, 8, 9, 11, 20, 21, 22, 25
GRPA, GRPB, GRPC, CMD, T, MT, V, MV, MCV, MOV, P, DP, E, OT, CT, M, DS = (26, 27, 28, 29, 42, 43, 44, 45, 46, 47, 48, 50,
                                                                         52, 54, 56, 58, 60)
UPSECS, CTS, PIDX, HSG, LSG, IVEL, HOLD, TSTOP, KP, KD, KI, ACCEL, JP, TACT, TACTID, IHIT = (63, 68, 70, 71, 72, 73,
                                                                                            *range(77, 83), 96, 106, 107, 108)
IDLE, PID, TRAPEZOID = 0, 3, 5  # modes
ASLEEP, READY = 0, 2  # states
RESET, HI, CLOSE, MOVE, OPEN = 2, 13, 18, 19, 20  # commands
WIDE = {P, DP, E, OT, CT, M, CTS, JP}  # 32 bits
OF_MONITOR = {VERS, ROLE, SN, ID, ERROR, STAT}
SETTABLE = {STAT, MODE, OTEMP, GRPA, GRPB, GRPC, CMD, T, MT, V, MV, MCV, MOV, P, DP, E, OT, CT, M, DS, PIDX, HSG, LSG, IVEL,
            HOLD, TSTOP, KP, KD, KI, ACCEL, TACT, IHIT}
WRITE_ONLY = {CMD, M}
