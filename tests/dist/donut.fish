complete -c donut -l width -d 'Columns, 1 to 4096, at most the terminal\'s [default: the terminal\'s, 80 on a pipe]' -r
complete -c donut -l height -d 'Rows, 1 to 4096, at most the terminal\'s less 2 [default: the terminal\'s less 2, 22 on a pipe]' -r
complete -c donut -l fps -d 'Frames a second, up to 1000; 0 is as fast as possible' -r
complete -c donut -l frames -d 'Stop after N frames [default: never]' -r
complete -c donut -l method -d 'How a cell gets its glyph' -r -f -a "auto\t'classic for donut.c\'s own picture, 80x22, while its clock runs true; otherwise exact'
classic\t'donut.c\'s own: dots strewn over the surface, the nearest in each cell wins'
exact\t'One ray through each cell\'s centre, solved exactly: right at every size'"
complete -c donut -s A -d 'The first frame\'s turn about the x axis, in radians, -1e9 to 1e9' -r
complete -c donut -s B -d 'The first frame\'s turn about the z axis, in radians, -1e9 to 1e9' -r
complete -c donut -l spin -d 'Radians that A and B advance each frame, each -1e9 to 1e9' -r
complete -c donut -l color -d 'One colour: 0 to 255, #rrggbb, or red, green, yellow, blue, magenta, cyan or grey, each also as in dark_red, or black or white' -r
complete -c donut -l aspect -d 'Height of a character cell over its width, 0.1 to 10' -r
complete -c donut -l r1 -d 'Radius of the tube, 1e-6 to 1e6' -r
complete -c donut -l r2 -d 'Radius of the ring, from the donut\'s centre to the tube\'s: more than --r1' -r
complete -c donut -l k2 -d 'Distance from the viewer to the donut\'s centre: more than --r1 plus --r2' -r
complete -c donut -s h -l help -d 'Print help (see more with \'--help\')'
complete -c donut -s V -l version -d 'Print version'
