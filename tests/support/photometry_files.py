"""Small files of photometry, one of each format; some of their rows cannot be used."""

CSV = """\
# a remark
JD (UTC); mag [mag]; merr; Filter; stn; night
2455817.735937; 7.328; 0.004; R; 568; a
2455817.736235; 7.317; 0.004; R; 568; a
2455818.5; 7.5; ; V; 703; b
"""
ALCDEF = """\
STARTMETADATA
OBJECTNUMBER=1
OBJECTNAME=Example
SESSIONDATE=2011-09-13
OBSLONGITUDE=-116.38361
OBSLATITUDE=+34.29111
FILTER=R
DIFFERMAGS=FALSE
LTCAPP=NONE
REDUCEDMAGS=NONE
DELIMITER=PIPE
ENDMETADATA
DATA=2455817.735937|7.328|0.004
DATA=2455817.736235|7.317|0.004|1.2
DATA=2455817.736529
STARTMETADATA
OBJECTNAME=Example
SESSIONDATE=2011-09-16
OBSLONGITUDE=-116.38361
OBSLATITUDE=+34.29111
FILTER=C
EXPJD=START
EXPOSURE=86.4
LTCAPP=NONE
REDUCEDMAGS=NONE
DELIMITER=PIPE
ENDMETADATA
DATA=2455820.791028|7.189|0.008
"""
PSV = """\
# version=2017
# observatory
! mpcCode J95
permID |provID     |mode|stn |obsTime                |ra       |dec      |mag  |rmsMag|band|photCat
       |2023 XX5   | CCD|J95 |2023-07-06T00:17:43.77Z|273.13141|+40.61177|20.2 |0.14  |   G|Gaia2
       |2023 XX5   | CCD|J95 |2023-07-06T00:39:17.00Z|273.15447|+40.59873|     |      |    |
       |2023 XX5   | CCD|J95 |2023-13-06T00:39:17.00Z|273.15447|+40.59873|20.3 |      |   G|
"""
XML = """\
<?xml version="1.0" encoding="UTF-8"?>
<ades version="2022"><obsBlock><obsContext/><obsData>
<optical><permID>1</permID><stn>T12</stn><obsTime>2023-06-15T13:44:30.18Z</obsTime>
<mag>22.458</mag><rmsMag>0.1</rmsMag><band>G</band></optical>
<optical><stn>T12</stn><obsTime>2023-06-15T13:51:56.52Z</obsTime></optical>
</obsData></obsBlock></ades>
"""
MPC = """\
COD J38
OBS A. Observer
00085         C2023 03 05.99841 09 14 47.01 +01 24 38.9          12.4 GV     J38
00085         C2023 03 06.00131 09 14 46.89 +01 24 40.0          12.5 GV     J38
00085         C2023 03 06.00421 09 14 46.77 +01 24 41.4                      J38
"""
DAMIT = """\
2
2 1
2433827.771536 9.977964e-01 2.5 0.5 0.25 1.6 0.4 0.3
2433827.778296 1.008107e+00 2.5 0.5 0.25 1.6 0.4 0.3
1 0
2433828.5  0.5  -1 0 0   0 -2 0
"""
