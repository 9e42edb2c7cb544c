                       use std::{io::*,
                 iter::*,thread::sleep,time::
             *,f32::consts::TAU}; fn spin(by:f64)
          ->impl Iterator<Item=f32>{successors(Some(
        0.),move|&t|Some((f64::from(t)+by)as f32))}pub
      fn frame(a:f32,b:f32,[w,h]:[usize;2],[x,y,kx,ky]:[
    f32;4])->Vec<u8>{let around=|by|spin(by).take_while(|t
   |t<&TAU);let mut nearest=vec![0.;w*h];let mut dough=vec!
  [b' ';w*h];for j in around(0.07){for i in around(0.02){let
 [[sa,ca],[sb,cb],[si,ci],[        sj,cj]]=[a,b,i,j].map(|t|{
let(sin,cos)=f64::from(t              ).sin_cos();[sin as f32,
cos as f32]});let ring                  =cj+2.; let t=si*ring*
ca-sj*sa;let glaze=8.                    *((sj*sa-si*cj*ca)*cb
-si*cj*sa-sj*ca-ci*cj                    *sb);let near=1./(si*
ring*sa+sj*ca+5.);let                    y=(y+ky*near*(ci*ring
*sb+t*cb))as usize;let                  x=(x+kx*near*(ci*ring*
cb-t*sb))as usize;let o=              x+w*y;if(1..h).contains(
 &y)&&(1..w).contains(&x)&&        near>nearest[o]{nearest[o]
  =near;dough[o]=b".,-~:;=!*#$@"[glaze as usize];}}}dough}fn
   main(){print!("\x1b[2J"); for(a,b)in spin(0.04).zip(spin
    (0.02)){let mut donut=frame(a,b,[80,22], [40.,12.,30.,
      15.]); donut.chunks_mut(80).for_each(|bite|bite[0]
        =b'\n');if writeln!(stdout(),"\x1b[H{}",String
          ::from_utf8_lossy(&donut)).is_err(){break;
             }sleep(Duration::from_millis(33));}}
                 /* donut.c, A. Sloane, 2006;
                       baked in Rust */
